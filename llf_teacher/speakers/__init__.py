"""Teachers of studies that are no personalities alone: policies of one's own, models, personalities with a voice."""
