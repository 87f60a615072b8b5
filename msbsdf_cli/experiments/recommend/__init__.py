"""The least model that a scene's surfaces need."""
