"""What a run came to: results that merge, save and load, tables, and a report's directory."""
