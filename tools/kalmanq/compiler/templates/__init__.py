"""Files of C, and the report, with places for what Python makes; engine fills them."""
