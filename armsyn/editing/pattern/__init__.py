"""Motion patterns: learned from examples, kept in files."""
