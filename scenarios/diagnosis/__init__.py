"""What a diagnosis is written as: `diagnosis.json`, `report.html`, and `twin.toml`, from which the bench is rebuilt."""
