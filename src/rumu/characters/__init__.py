"""What is known of a character whoever writes it: strokes in order, their names, how parts are arranged."""
