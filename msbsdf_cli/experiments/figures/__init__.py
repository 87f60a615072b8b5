"""Figures of the papers, remade: a file each."""
