"""Reports: directories, tables and pictures; knows no physics."""
