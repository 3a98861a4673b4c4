"""Bodies that are sheets: surfaces of triangles in space with unknowns of their own."""
