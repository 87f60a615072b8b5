"""The commands, one file each: what the user types becomes a study and a report."""
