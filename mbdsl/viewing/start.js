// The start of the page.
fill();
bind();
readTheme();
if (data.followed) followBody(data.followed);
fit();
const asked = /[#&]t=([-+.\de]+)/.exec(location.hash);
if (asked) seek(Number(asked[1]));
else if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
