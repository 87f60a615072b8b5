"""How work is run: executors and progress."""
