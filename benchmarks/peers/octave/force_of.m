function F = force_of(y, p, memory)
  % The paper's F(y), eqs. 16, 20 and 22, with the damper acting along the buffer alone (the model's section 3) and
  % Baumgarte's terms in the last four rows.
  n_S = y(15);
  n_B = y(18);
  S = [cos(y(3)); sin(y(3))];
  B = [cos(y(6)); sin(y(6))];
  P = [cos(y(9)); sin(y(9))];
  normal = [-B(2); B(1)];
  r = y(7:8) - y(4:5);
  v = y(19:20) - y(16:17);
  D = r - p.l_r * P + p.h * B;
  dD = v - p.l_r * y(21) * [-P(2); P(1)] + p.h * n_B * normal;
  L = norm(D);
  u = D / L;
  f = p.k_A * (L - p.l_0) + p.c_A * (dD' * u);
  twist = p.k_T * (y(6) - y(3)) + p.c_T * (n_B - n_S);
  c = contact_of(y, p, memory);
  Q = c.load;
  Q(3) = twist;
  Q(4:5) = f * u;
  Q(6) = -p.h * f * (B(1) * u(2) - B(2) * u(1)) - twist;
  Q(7:8) = Q(7:8) - f * u;
  Q(9) = Q(9) + p.l_r * f * (P(1) * u(2) - P(2) * u(1));
  phi = [y(1:2) + p.a * S - y(4:5) - p.h * B; y(6) - y(9); normal' * r];
  dphi = [y(13:14) + p.a * n_S * [-S(2); S(1)] - y(16:17) - p.h * n_B * normal; n_B - y(21); ...
          normal' * v - n_B * (B' * r)];
  gamma = [p.a * n_S^2 * S - p.h * n_B^2 * B; 0; 2 * n_B * (B' * v) + n_B^2 * phi(4)];
  F = [y(13:24); Q; gamma - 2 * p.gain * dphi - p.gain^2 * phi];
  if p.rolling
    F(29) = c.tip;
  else
    F(9 + 12) = F(9 + 12) + c.tip;
  end
end
