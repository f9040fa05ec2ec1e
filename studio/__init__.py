"""What people see: one designer's session, the 3D scene and panel (Viser), and the studio's own HTTP."""
