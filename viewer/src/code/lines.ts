/** Lines of a program in Python: which of them begin a statement that waits. */

/** Statements with a body of their own: nothing can be put before them in their line. */
const COMPOUND = /^(if|elif|else|for|while|with|try|except|finally|def|class|async|@)\b|^@/;

/** Puts a call that says its line before each statement that waits. Lines keep their numbers. */
export function markWaiting(program: string): string {
  let [depth, quote] = [0, ''];
  const lines = program.split('\n').map((line, index) => {
    const begins = depth === 0 && quote === '';
    const code = codeOf(line);
    const [, indent = '', statement = ''] = /^(\s*)(.*)$/.exec(line) ?? [];
    const isMarked = begins && /\bawait\b/.test(code) && !COMPOUND.test(statement);
    return isMarked ? `${indent}_page.at(${index + 1}); ${statement}` : line;
  });
  return lines.join('\n');

  /** Returns what of a line is neither text nor comment, and keeps count of open brackets and texts. */
  function codeOf(line: string): string {
    let code = '';
    for (let at = 0; at < line.length; at++) {
      const letter = line[at]!;
      if (quote !== '') {
        if (letter === '\\') at++;
        else if (line.startsWith(quote, at)) {
          at += quote.length - 1;
          quote = '';
        }
        continue;
      }
      if (letter === '#') break;
      if (letter === '"' || letter === "'") {
        quote = line.startsWith(letter.repeat(3), at) ? letter.repeat(3) : letter;
        at += quote.length - 1;
        continue;
      }
      if ('([{'.includes(letter)) depth++;
      if (')]}'.includes(letter)) depth = Math.max(0, depth - 1);
      code += letter;
    }
    // A text in single quotes ends with its line.
    if (quote.length === 1) quote = '';
    return code;
  }
}

/** Returns the error of a traceback, with the last line of the program that led to it. */
export function plainError(traceback: string): string {
  const lines = traceback.trim().split('\n');
  const numbers = [...traceback.matchAll(/File "<stdin>", line (\d+)/g)].map(([, number]) => number);
  const [last, error] = [numbers.at(-1), lines.at(-1) ?? ''];
  return last === undefined ? error : `line ${last}: ${error}`;
}
