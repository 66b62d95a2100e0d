"""Files of C with places for what Python makes; engine fills them."""
