"""What is seen in pictures, how right it is and how long it takes."""
