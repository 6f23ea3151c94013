"""Teachers of a study beside personalities: users' own policies, models, personalities with a voice."""
