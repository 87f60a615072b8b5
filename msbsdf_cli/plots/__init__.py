"""Figures of reports, a file each."""
