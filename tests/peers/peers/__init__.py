"""The contenders, the processes that hold them, and the rounds in which they are timed."""
