"""Pictures: what is to be drawn, as data; drawn to a file, or to a page that stands by itself."""
