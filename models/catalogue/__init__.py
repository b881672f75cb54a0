"""What every effect stands on: its declaration, what it may know, how it predicts, is injected and corrected for."""
