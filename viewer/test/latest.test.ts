import { describe, expect, it } from 'vitest';
import { Latest, type Wish } from '../src/latest';

/** A wish whose answers are given by hand. */
function scene() {
  const asked: string[] = [];
  const answers: (() => void)[] = [];
  const state = { key: undefined as string | undefined, drawn: 0 };
  const wish = (): Wish | undefined => {
    const { key } = state;
    if (key === undefined) return undefined;
    return {
      key,
      ask: () => {
        asked.push(key);
        return new Promise<void>((done) => answers.push(done));
      },
    };
  };
  const latest = new Latest(wish, () => ++state.drawn);
  const settle = () => new Promise((done) => setTimeout(done));
  return { asked, answers, state, latest, settle };
}

describe('what follows a wish', () => {
  it('asks once for one wish, however often it is told', async () => {
    const { asked, answers, state, latest, settle } = scene();
    state.key = 'a';
    const all = [latest.follow(), latest.follow()];
    await settle();
    answers[0]!();
    await Promise.all(all);
    await latest.follow();
    expect(asked).toEqual(['a']);
    expect(state.drawn).toBeGreaterThan(0);
  });

  it('passes over wishes that came and went while an answer was on its way', async () => {
    const { asked, answers, state, latest, settle } = scene();
    state.key = 'a';
    const end = latest.follow();
    await settle();
    state.key = 'b';
    void latest.follow();
    state.key = 'c';
    void latest.follow();
    answers[0]!();
    await settle();
    answers[1]!();
    await end;
    expect(asked).toEqual(['a', 'c']);
  });

  it('still follows after it was told what it had already, or that nothing is wanted', async () => {
    const { asked, answers, state, latest, settle } = scene();
    state.key = 'a';
    const end = latest.follow();
    await settle();
    answers[0]!();
    await end;
    await latest.follow();
    state.key = undefined;
    const drawn = state.drawn;
    await latest.follow();
    expect(state.drawn).toBe(drawn + 1);
    state.key = 'b';
    const next = latest.follow();
    await settle();
    answers[1]!();
    await next;
    expect(asked).toEqual(['a', 'b']);
  });
});
