"""The diagnosis of a moving recording from the folder to its files: data, words, figures and pages."""
