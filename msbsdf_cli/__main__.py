"""`python -m msbsdf_cli` is the command line."""

from msbsdf_cli.cli import main

main()
