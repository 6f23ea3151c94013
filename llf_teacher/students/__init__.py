"""Students: policies for the student's seat, named by spec strings such as `q_learning(alpha=0.5)`."""
