"""The Smith model: pure functions over arrays; knows no files, no plots, no command line."""
