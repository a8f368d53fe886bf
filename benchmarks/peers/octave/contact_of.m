function c = contact_of(y, p, memory)
  % Contact of the tip with both flanks, lower first: the model's sections 4 and 5.
  % c.gap (1,2) [m], c.rate (1,2) [m/s] within REACH of the flank; c.force (1,2) [N]; c.x [m] the tip centre in the
  % frame of T; and the generalised forces c.load (12,1) [N, N m] with the moment c.tip [N m] about the tip centre.
  REACH = 1e-9;
  sP = sin(y(9));
  cP = cos(y(9));
  turn = [cos(y(12)), -sin(y(12)); sin(y(12)), cos(y(12))];
  A = turn' * (y(7:8) + p.l_t * [cP; sP] - y(10:11));
  V = turn' * (y(19:20) + p.l_t * y(21) * [-sP; cP] - y(22:23));
  if p.rolling
    spin = y(29);
  else
    spin = y(21);
  end
  c.x = A(1);
  c.gap = [0, 0];
  c.rate = [0, 0];
  c.force = [0, 0];
  c.load = zeros(12, 1);
  c.tip = 0;
  for k = 1:2
    sigma = 3 - 2 * k;
    t = [p.cos_beta; sigma * p.sin_beta];
    E = [-p.L_T; -sigma * p.R_c];
    s = min(max(-(A - E)' * t, 0), p.L_c);
    foot = E - s * t;
    N = A - foot;
    d = norm(N);
    c.gap(k) = d - p.R;
    if c.gap(k) > REACH
      continue
    end
    N = N / d;
    T = sigma * [N(2); -N(1)];
    v = V + spin * d * [N(2); -N(1)] - y(24) * [-foot(2); foot(1)];
    c.rate(k) = v' * N;
    if c.gap(k) >= 0 || memory(k) == 0
      continue
    end
    Fn = p.K * (-c.gap(k))^1.5 * max(0, 1 - p.chi * c.rate(k) / memory(k));
    Ft = -p.mu * Fn * tanh((v' * T) / p.v_s);
    F = Fn * N + Ft * T;
    W = turn * F;
    c.force(k) = Fn;
    c.tip = c.tip + sigma * d * Ft;
    c.load(7:8) = c.load(7:8) + W;
    c.load(9) = c.load(9) + p.l_t * (cP * W(2) - sP * W(1));
    c.load(10:11) = c.load(10:11) - W;
    c.load(12) = c.load(12) - (foot(1) * F(2) - foot(2) * F(1));
  end
end
