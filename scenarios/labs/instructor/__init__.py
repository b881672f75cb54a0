"""For the instructor: goals, time and solutions of each lab, and mistakes that its checks must catch."""
