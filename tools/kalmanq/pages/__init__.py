"""What is shown: pictures, and the page of a report with its charts and verdict."""
