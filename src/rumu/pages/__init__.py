"""A photographed or scanned page -> its characters; sheets that are printed and read back."""
