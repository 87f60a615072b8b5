"""What takes results into renderers."""
