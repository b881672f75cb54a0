"""The camera's calibration as a job: photographs searched, models compared, words and a page for people."""
