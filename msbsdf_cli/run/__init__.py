"""How work is run: named random streams."""
