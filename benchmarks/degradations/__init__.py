"""What cameras do to pictures, one case after the other, and what sensing makes of them."""
