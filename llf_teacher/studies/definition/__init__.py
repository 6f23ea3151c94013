"""What a study is: its lists, and what it may declare beside them."""
