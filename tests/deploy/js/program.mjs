// What the built program says about itself: its version and the options of its commands.
import { execFileSync } from 'node:child_process';

const say = (program, ...words) => execFileSync(program, words, { encoding: 'utf8' });

export const versionOf = (program) => say(program, '--version').trim();

const helpOf = (program, words) => say(program, ...words, '--help');

// Adds a fault for each option of a command line and each variable DIVEMESH_... that the program does not have.
// Variables may be those of any of the commands.
export function checkOptions(faults, where, program, words, variables = []) {
  const command = [];
  for (const word of words) {
    if (word.startsWith('-')) break;
    command.push(word);
  }
  const help = helpOf(program, command);
  for (const word of words.filter((each) => each.startsWith('--')))
    faults.expect(
      new RegExp(`^ +${word}[ =,]`, 'm').test(help),
      `${where}: divemesh ${command.join(' ')} has no ${word}`,
    );
  const all = help + helpOf(program, ['serve']) + helpOf(program, ['worker']);
  for (const variable of variables.filter((each) => each.startsWith('DIVEMESH_')))
    faults.expect(all.includes(`(Env:${variable})`), `${where}: no option is set by ${variable}`);
}
