"""Running a scenario: stages that read what earlier stages wrote, so that a killed run goes on where it was."""
