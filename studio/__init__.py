"""What people see: one designer's session, the 3D scene (Viser), and the studio's own HTTP."""
