% Made from bookcase.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(bookcase, []).
:- use_module(facetlog(vocabulary)).
% bookcase.model:1
model(bookcase, "A high shelf for books, in three rows at least.", [top]).

% bookcase.model:1
specialises(bookcase, shelf).

% shelf.model:10  parts
candidate(bookcase, Thing, Parts) :-
    findall(Parts, likely(bookcase, Thing, Parts), Found),
    ( Found == [] -> distant(bookcase, Thing, Parts) ; member(Parts, Found) ).

% shelf.model:10  all that may satisfy its lines
likely(bookcase, Thing, [Top]) :-
    face_of(Thing, Top),
    possible(all([measured(Top), level(Top), upward(Top), at_least(share(Top), 0.7),
                  at_most(protrusion(Top), 0.2*elevation(Top)),
                  at_least(thing_height(Thing), 1.1*length(Top))])).

% shelf.model:10  near misses
distant(bookcase, Thing, [Top]) :-
    as_far_as_seen(Thing, [step(Top, 20, all([measured(Top), level(Top), upward(Top)]))], [Top]).

% shelf.model:11  board is level, board is upward, low(board), overlap(board, top) at least 80 %
means('bookcase.board'(Board, Top),
      all([level(Board), upward(Board),
           soft(at_most(elevation(Board), 0.8*elevation(Top)), 0.1),
           soft(at_least(overlap(Board, Top), 0.8), 0.1)])).
% shelf.model:13  side is upright, height(side) at least 80 % of height(this), width(side) at least 50 % of width(top)
means('bookcase.side'(Side, Top, Thing),
      all([upright(Side), soft(at_least(height(Side), 0.8*thing_height(Thing)), 0.1),
           soft(at_least(width(Side), 0.5*width(Top)), 0.1)])).
% shelf.model:15  shut is upright, share(shut) at least 70 %, protrusion(shut) at most 20 % of width(top)
means('bookcase.shut'(Shut, Top),
      all([upright(Shut), soft(at_least(share(Shut), 0.7), 0.1),
           soft(at_most(protrusion(Shut), 0.2*width(Top)), 0.1)])).

% shelf.model:11
members(bookcase, board, Thing, [Top], Members) :-
    findall(Board,
            ( face_of(Thing, Board), \+ memberchk(Board, [Top]),
              possible('bookcase.board'(Board, Top)) ), Found),
    sort(Found, Members).
% shelf.model:13
members(bookcase, side, Thing, [Top], Members) :-
    findall(Side,
            ( face_of(Thing, Side), \+ memberchk(Side, [Top]),
              possible('bookcase.side'(Side, Top, Thing)) ), Found),
    sort(Found, Members).
% shelf.model:15
members(bookcase, shut, Thing, [Top], Members) :-
    findall(Shut,
            ( face_of(Thing, Shut), \+ memberchk(Shut, [Top]),
              possible('bookcase.shut'(Shut, Top)) ), Found),
    sort(Found, Members).

% shelf.model:11  at least 2 separate faces board where board is level, board is upward, low(board), overlap(board, top) at least 80 %
condition(bookcase, board, "two boards at least lie below the top one", Thing, [Top],
          at_least_of(2, Board, Board_groups, 'bookcase.board'(Board, Top))) :-
    members(bookcase, board, Thing, [Top], Board_members),
    separate(Board_members, Board_groups).
% shelf.model:13  at least 2 separate faces side where side is upright, height(side) at least 80 % of height(this), width(side) at least 50 % of width(top)
condition(bookcase, side, "it has two upright sides as high as itself", Thing, [Top],
          at_least_of(2, Side, Side_groups, 'bookcase.side'(Side, Top, Thing))) :-
    members(bookcase, side, Thing, [Top], Side_members),
    separate(Side_members, Side_groups).
% shelf.model:18  top is measured, top is level, top is upward
condition(bookcase, level, "the topmost board is level and faces up", _, [Top],
          all([measured(Top), level(Top), upward(Top)])).
% shelf.model:19  share(top) at least 70 %
condition(bookcase, cover, "the boards reach from side to side", _, [Top],
          soft(at_least(share(Top), 0.7), 0.1)).
% shelf.model:20  protrusion(top) at most 20 % of elevation(top)
condition(bookcase, topmost, "little rises above the topmost board", _, [Top],
          soft(at_most(protrusion(Top), 0.2*elevation(Top)), 0.1)).
% shelf.model:21  gap_below(top) or there is a face f where f underside_of top, gap_below(f)
condition(bookcase, spaced, "there is room between the topmost board and the next", Thing,
          [Top],
          any([soft(between(clear_below(Top), 0.04*elevation(Top), 0.6*elevation(Top)), 0.1),
               some(F, Fs,
                    all([underside_of(F, Top),
                         soft(between(clear_below(F), 0.04*elevation(Top), 0.6*elevation(Top)),
                              0.1)]))])) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [Top]),
              possible(all([underside_of(F, Top),
                            between(clear_below(F), 0.04*elevation(Top), 0.6*elevation(Top))])) ),
            Found),
    sort(Found, Fs).
% shelf.model:23  count(shut) at most 3
condition(bookcase, open, "one side is open", Thing, [Top],
          at_most_of(3, Shut, Shut_groups, 'bookcase.shut'(Shut, Top))) :-
    members(bookcase, shut, Thing, [Top], Shut_members),
    findall([Member], member(Member, Shut_members), Shut_groups).
% shelf.model:24  each face f where area(f) at least 20 % of length(this) * width(this): f is level or f is upright
condition(bookcase, straight, "its large faces are level or upright", Thing, [Top],
          each(F, Fs,
               implies(soft(at_least(area(F), 0.2*thing_length(Thing)*thing_width(Thing)), 0.1),
                       any([level(F), upright(F)])))) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [Top]),
              possible(at_least(area(F), 0.2*thing_length(Thing)*thing_width(Thing))) ),
            Found),
    sort(Found, Fs).
% bookcase.model:4  count(board) at least 3
condition(bookcase, rows, "three boards at least lie below the topmost", Thing, [Top],
          at_least_of(3, Board, Board_groups, 'bookcase.board'(Board, Top))) :-
    members(bookcase, board, Thing, [Top], Board_members),
    separate(Board_members, Board_groups).
% bookcase.model:5  height(this) at least 110 % of length(top)
condition(bookcase, tall, "it is higher than broad", Thing, [Top],
          soft(at_least(thing_height(Thing), 1.1*length(Top)), 0.1)).

written(bookcase, board, 'shelf.model:11',
        "at least 2 separate faces board where board is level, board is upward, low(board), overlap(board, top) at least 80 %").
written(bookcase, side, 'shelf.model:13',
        "at least 2 separate faces side where side is upright, height(side) at least 80 % of height(this), width(side) at least 50 % of width(top)").
written(bookcase, level, 'shelf.model:18', "top is measured, top is level, top is upward").
written(bookcase, cover, 'shelf.model:19', "share(top) at least 70 %").
written(bookcase, topmost, 'shelf.model:20', "protrusion(top) at most 20 % of elevation(top)").
written(bookcase, spaced, 'shelf.model:21',
        "gap_below(top) or there is a face f where f underside_of top, gap_below(f)").
written(bookcase, open, 'shelf.model:23', "count(shut) at most 3").
written(bookcase, straight, 'shelf.model:24',
        "each face f where area(f) at least 20 % of length(this) * width(this): f is level or f is upright").
written(bookcase, rows, 'bookcase.model:4', "count(board) at least 3").
written(bookcase, tall, 'bookcase.model:5', "height(this) at least 110 % of length(top)").

% shelf.model:11
group(bookcase, Thing, [Top], board, Members) :-
    members(bookcase, board, Thing, [Top], Board_members),
    findall(Board, ( member(Board, Board_members), holds('bookcase.board'(Board, Top)) ),
            Members).
% shelf.model:13
group(bookcase, Thing, [Top], side, Members) :-
    members(bookcase, side, Thing, [Top], Side_members),
    findall(Side, ( member(Side, Side_members), holds('bookcase.side'(Side, Top, Thing)) ),
            Members).
% shelf.model:15
group(bookcase, Thing, [Top], shut, Members) :-
    members(bookcase, shut, Thing, [Top], Shut_members),
    findall(Shut, ( member(Shut, Shut_members), holds('bookcase.shut'(Shut, Top)) ), Members).

% shelf.model:27
size(bookcase, _, [Top], width, length(Top)).
% shelf.model:28
size(bookcase, _, [Top], depth, width(Top)).
% shelf.model:29
size(bookcase, Thing, [_], height, thing_height(Thing)).
