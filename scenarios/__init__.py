"""Declares and runs whole jobs: scenario files, runner, command line, reports."""
