"""What comes in and goes out: rows of numbers, tables of any layout, times, files that are written whole or not at all."""
