"""The tables of the near layer: synonyms and patterns of slots, of all families and of each."""
