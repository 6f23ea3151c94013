"""One voice a file: frames around plain sentences, and words of its own for claims that belong to no family."""
