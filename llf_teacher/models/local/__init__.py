"""Language models on this machine: their catalogue, their download, and the server process of each."""
