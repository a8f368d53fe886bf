% Read a capture's numbers from the JSON file named first, run it as often as named second, print the last run as JSON.
arguments = argv();
job = jsondecode(fileread(arguments{1}));
for k = 1:str2double(arguments{2})
  result = capture(job.design, job.state, job.memory(:)', job.duration, job.rtol, job.atol);
end
printf('RESULT %s\n', jsonencode(result));
