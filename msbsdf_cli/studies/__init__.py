"""Questions put to the models and the surfaces."""
