"""Reports: one HTML file that opens offline, made of sections that can be composed."""
