function D = mass_of(y, p)
  % The paper's D(y), eqs. 16 to 18, with the slips of its eq. 18 put right (the model's section 9).
  % Unknowns: positions 1 to 12, velocities 13 to 24, integrals of the multipliers 25 to 28, spin of a free tip 29.
  a = p.a;
  h = p.h;
  c3 = cos(y(3));
  s3 = sin(y(3));
  c6 = cos(y(6));
  s6 = sin(y(6));
  w = (y(7) - y(4)) * c6 + (y(8) - y(5)) * s6;
  J = zeros(4, 12);
  J(1, [1, 3, 4, 6]) = [1, -a * s3, -1, h * s6];
  J(2, [2, 3, 5, 6]) = [1, a * c3, -1, -h * c6];
  J(3, [6, 9]) = [1, -1];
  J(4, 4:8) = [s6, -c6, -w, -s6, c6];
  D = p.D;
  D(13:24, 25:28) = J';
  D(25:28, 13:24) = J;
end
