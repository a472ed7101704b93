"""Straight lines in pictures and in space, and planes of lines, by the recursion of the paper."""
