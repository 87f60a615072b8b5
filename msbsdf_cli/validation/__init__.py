"""The published identities of the models, each measured, with a verdict that holds for all."""
