"""Teachers of a study that are more than a personality: the user's own policies, models, personalities with a voice."""
