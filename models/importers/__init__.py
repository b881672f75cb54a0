"""Other people's logs as recordings: one format a file, and what it took for what told in notes."""
