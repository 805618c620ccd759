// What happens inside a click, in sentences made from its pulses.

/** What has happened last at `now` (s of the run): {text, detail}. */
function captionOf(click, now, state, rigid) {
  if (rigid || click.length === 0) return { text: say("overRigid", click.pulses.length), detail: outcome(click) };
  if (now < click.begin) {
    const { contact } = click.pulses[0];
    return { text: say("approaching", contact + 1, contact + 2, quantity(click.begin - now, "s", 2)), detail: "" };
  }
  if (now >= click.end) return { text: say("over", quantity(click.length, "s"), click.pulses.length), detail: outcome(click) };
  const event = lastEvent(click, now);
  const strongest = Math.max(0, ...state.F);
  return {
    text: sentence(event, click.pulses),
    detail: say("sinceTouch", quantity(now - click.begin, "s"), strongest > 0 ? quantity(strongest, "N") : ""),
  };
}

/** The last onset or release up to `now`: {time, contact, onset}. Of balls in touch, which all are pressed from the same instant on, it
 *  is the contact that closes fastest. */
function lastEvent({ pulses, speeds }, now) {
  const closing = (contact) => speeds[contact] - speeds[contact + 1];
  let last = { time: -Infinity };
  for (const { contact, onset, release } of pulses) {
    const slower = last.onset && onset === last.time && closing(contact) <= closing(last.contact);
    if (onset <= now && onset >= last.time && !slower) last = { time: onset, contact, onset: true };
    if (release <= now && release >= last.time) last = { time: release, contact, onset: false };
  }
  return last;
}

/** One sentence on an event, with what touches meanwhile. Balls are counted from 1. */
function sentence({ time, contact, onset }, pulses) {
  const closed = pulses.filter((pulse) => pulse.contact !== contact && pulse.onset < time && pulse.release > time).map((pulse) => pulse.contact);
  const nearest = closed.sort((a, b) => Math.abs(a - contact) - Math.abs(b - contact))[0];
  if (nearest === undefined) return say(onset ? "touch" : "part", contact + 1, contact + 2);
  if (!onset) return say("partWhile", nearest < contact ? contact + 2 : contact + 1, nearest + 1, nearest + 2);
  if (nearest === contact - 1) return say("touchWhile", contact, contact + 1, contact + 2);
  if (nearest === contact + 1) return say("touchWhileRight", contact + 1, contact + 2, contact + 3);
  return `${say("touch", contact + 1, contact + 2)} ${say("stillPressed", closed.length + 1)}`;
}

/** Which balls move after a click, and how fast, in percent of the fastest that came in. */
function outcome(click, most = 4) {
  const fastest = Math.max(...click.speeds.map(Math.abs)) || 1;
  const parts = click.after.map((v, i) => ({ ball: i + 1, part: v / fastest })).filter(({ part }) => Math.abs(part) >= 0.005);
  parts.sort((a, b) => Math.abs(b.part) - Math.abs(a.part));
  const list = parts.slice(0, most).sort((a, b) => a.ball - b.ball).map(({ ball, part }) => {
    const percent = 100 * part;
    return say("leaver", ball, (Math.abs(percent) > 99 && Math.abs(percent) < 99.95 ? percent.toFixed(1) : percent.toFixed(0)).replace("-", "−"));
  });
  return say("leave", list.length ? `${list.join(", ")}${parts.length > most ? " …" : ""}` : say("all"));
}
