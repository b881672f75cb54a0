"""The checks of each lab: what a student's answer is held against, and what is said of a wrong one."""
