function r = capture(p, y0, memory, duration, rtol, atol)
  % One capture by ode15s on the paper's own form D(y) y' = F(y).
  % p: numbers of the design; y0 (28 or 29,1); memory (1,2) [m/s] approach speeds of the latest touchdowns, 0 for a
  % flank that has not been touched yet; duration [s].
  % A touchdown ends a run of ode15s and the next run starts with the new memory, because the remembered approach speed
  % jumps there. A release ends nothing: the force has come down to zero by itself.
  p = prepare(p);
  outcomes = {'captured', 'escaped'};
  r.outcome = 'timeout';
  r.impacts = 1;
  t0 = 0;
  pieces = {};
  clock = tic();
  while t0 < duration
    slope = mass_of(y0, p) \ force_of(y0, p, memory);
    options = odeset('RelTol', rtol, 'AbsTol', atol, 'Mass', @(t, y) mass_of(y, p), 'InitialSlope', slope, ...
                     'MStateDependence', 'strong', 'InitialStep', 1e-5, 'Events', @(t, y) watch_of(y, p, memory));
    [t, y, te, ~, ie] = ode15s(@(t, y) force_of(y, p, memory), [t0, duration], y0, options);
    pieces{end + 1} = {t(1:end - 1), y(1:end - 1, :), memory};
    if isempty(ie)
      t0 = t(end);
      break
    end
    event = ie(end);  % the first may be the touchdown this run started from
    [t0, y0] = settle(event, t(end - 1), y(end - 1, :)', te(end), p, memory);
    if event > 2
      r.outcome = outcomes{event - 2};
      break
    end
    c = contact_of(y0, p, [0, 0]);
    memory(event) = max(-c.rate(event), 1e-5);
    r.impacts = r.impacts + 1;
  end
  r.seconds = toc(clock);
  r.end_time = t0;
  r.steps = sum(cellfun(@(piece) numel(piece{1}), pieces));
  [r.peak_force, r.peak_time, r.peak_flank] = highest(pieces, p);
end

function p = prepare(p)
  % The constant part of D(y).
  n = 28 + p.rolling;
  D = zeros(n);
  D(1:12, 1:12) = eye(12);
  D(13:24, 13:24) = diag([p.m_S, p.m_S, p.I_S, p.m_B, p.m_B, p.I_B, p.m_P, p.m_P, p.I_P, p.m_T, p.m_T, p.I_T]);
  if p.rolling
    D(29, 29) = p.I_t;
  end
  p.D = D;
end

function [t, y] = settle(event, t1, y1, t, p, memory)
  % ode15s puts an event on the straight line between two steps. Find it anew, from the step before, on a flight
  % without the flank that is about to be touched.
  if event < 3
    memory(event) = 0;
  end
  left = t1;
  value_left = watch_of(y1, p, memory)(event);
  for k = 1:20
    y = flight(y1, t - t1, p, memory);
    value = watch_of(y, p, memory)(event);
    if abs(value) < 1e-14 || t == left
      return
    end
    [t, left, value_left] = deal(t - value * (t - left) / (value - value_left), t, value);
  end
end

function y = flight(y, h, p, memory)
  % Four steps of the classical Runge-Kutta method over h [s].
  h = h / 4;
  f = @(y) mass_of(y, p) \ force_of(y, p, memory);
  for k = 1:4
    k1 = f(y);
    k2 = f(y + h / 2 * k1);
    k3 = f(y + h / 2 * k2);
    k4 = f(y + h * k3);
    y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  end
end

function [force, time, flank] = highest(pieces, p)
  % Top of the forces [N] over the steps of all pieces, by the quartic through the five steps around it.
  force = 0;
  time = 0;
  flank = 1;
  for n = 1:numel(pieces)
    [t, y, memory] = pieces{n}{:};
    forces = zeros(numel(t), 2);
    for m = 1:numel(t)
      forces(m, :) = contact_of(y(m, :)', p, memory).force;
    end
    [tops, places] = max(forces);
    for k = 1:2
      if tops(k) < 0.9 * force || tops(k) == 0
        continue
      end
      first = min(max(places(k) - 2, 1), numel(t) - 4);
      around = first:first + 4;
      centre = t(places(k));
      width = t(first + 4) - t(first);
      c = polyfit((t(around) - centre) / width, forces(around, k), 4);
      s = roots(polyder(c));
      s = real(s(abs(imag(s)) < 1e-9));
      [~, nearest] = min(abs(s));
      top = polyval(c, s(nearest));
      if top > force
        force = top;
        time = centre + s(nearest) * width;
        flank = k;
      end
    end
  end
end
