function [value, terminal, direction] = watch_of(y, p, memory)
  % What ends a run of ode15s: a gap closing (2), the capture plane, the escape plane.
  c = contact_of(y, p, memory);
  value = [c.gap(:); -p.L_T - p.R * p.sin_beta - c.x; c.x + p.L_T + 2 * p.L_c];
  terminal = [1; 1; 1; 1];
  direction = [-1; -1; -1; -1];
end
