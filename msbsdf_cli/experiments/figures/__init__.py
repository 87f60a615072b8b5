"""Figures of the papers, remade: a file for each group of them, `catalogue` lists them all.

A figure is a function of `Settings` that returns tables by the name of their file; the file of the
same name in `plots/figures` draws it from these tables alone.
"""
