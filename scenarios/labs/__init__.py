"""Labs without a robot: notebooks for a student, checks that do not give the answer away, pages for the instructor."""
