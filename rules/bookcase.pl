% Made from bookcase.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(bookcase, []).
:- use_module(facetlog(vocabulary)).
% bookcase.model:1
model(bookcase, "A high shelf for books, in three rows at least.", [top, left, right]).

% bookcase.model:1
specialises(bookcase, shelf).

% shelf.model:11  parts
candidate(bookcase, Thing, Parts) :-
    findall(Parts, likely(bookcase, Thing, Parts), Found),
    ( Found == [] -> distant(bookcase, Thing, Parts) ; member(Parts, Found) ).

% shelf.model:11  all that may satisfy its lines
likely(bookcase, Thing, [Top, Left, Right]) :-
    face_of(Thing, Top),
    possible(all([measured(Top), level(Top), upward(Top), at_least(share(Top), 0.7),
                  at_most(protrusion(Top), 0.2*elevation(Top)),
                  at_least(thing_height(Thing), 1.1*length(Top))])),
    face_of(Thing, Left),
    Left \== Top,
    possible(all([upright(Left), at_least(height(Left), 0.8*thing_height(Thing))])),
    possible(at_least(width(Left), 0.5*width(Top))),
    face_of(Thing, Right),
    Right \== Top,
    Right \== Left,
    possible(all([upright(Right), at_least(height(Right), 0.8*thing_height(Thing))])),
    possible(all([opposite(Left, Right), at_least(width(Right), 0.5*width(Top)),
                  any([at_least(offset(Left, Right), 0.5*width(Top)),
                       at_most(offset(Left, Right), -(0.5*width(Top)))])])).

% shelf.model:11  near misses
distant(bookcase, Thing, [Top, Left, Right]) :-
    as_far_as_seen(Thing,
                   [step(Top, 6, all([measured(Top), level(Top), upward(Top)])),
                    step(Left, 3, upright(Left)), step(Right, 3, upright(Right))],
                   [Top, Left, Right]).

% shelf.model:12  board is level, board is upward, elevation(board) at most 80 % of elevation(top), overlap(board, top) at least 80 %
means('bookcase.board'(Board, Top),
      all([level(Board), upward(Board),
           soft(at_most(elevation(Board), 0.8*elevation(Top)), 0.1),
           soft(at_least(overlap(Board, Top), 0.8), 0.1)])).
% shelf.model:15  shut is upright, share(shut) at least 70 %, protrusion(shut) at most 20 % of width(top), not parallel(shut, left, 15 deg)
means('bookcase.shut'(Shut, Top, Left),
      all([upright(Shut), soft(at_least(share(Shut), 0.7), 0.1),
           soft(at_most(protrusion(Shut), 0.2*width(Top)), 0.1), not(parallel(Shut, Left, 15))])).

% shelf.model:12
members(bookcase, board, Thing, [Top, Left, Right], Members) :-
    findall(Board,
            ( face_of(Thing, Board), \+ memberchk(Board, [Top, Left, Right]),
              possible('bookcase.board'(Board, Top)) ), Found),
    sort(Found, Members).
% shelf.model:15
members(bookcase, shut, Thing, [Top, Left, Right], Members) :-
    findall(Shut,
            ( face_of(Thing, Shut), \+ memberchk(Shut, [Top, Left, Right]),
              possible('bookcase.shut'(Shut, Top, Left)) ), Found),
    sort(Found, Members).

% shelf.model:12  at least 2 separate faces board where board is level, board is upward, elevation(board) at most 80 % of elevation(top), overlap(board, top) at least 80 %
condition(bookcase, board, "two boards at least lie below the top one", Thing,
          [Top, Left, Right], at_least_of(2, Board, Board_groups, 'bookcase.board'(Board, Top))) :-
    members(bookcase, board, Thing, [Top, Left, Right], Board_members),
    separate(Board_members, Board_groups).
% shelf.model:18  top is measured, top is level, top is upward
condition(bookcase, level, "the topmost board is level and faces up", _, [Top, _, _],
          all([measured(Top), level(Top), upward(Top)])).
% shelf.model:19  left opposite right, (each x of left, right: x is upright, height(x) at least 80 % of height(this), width(x) at least 50 % of width(top)), apart(left, right)
condition(bookcase, sides, "it has two upright sides as high as itself", Thing,
          [Top, Left, Right],
          all([opposite(Left, Right),
               each(X, [Left, Right],
                    all([upright(X), soft(at_least(height(X), 0.8*thing_height(Thing)), 0.1),
                         soft(at_least(width(X), 0.5*width(Top)), 0.1)])),
               any([soft(at_least(offset(Left, Right), 0.5*width(Top)), 0.1),
                    soft(at_most(offset(Left, Right), -(0.5*width(Top))), 0.1)])])).
% shelf.model:23  share(top) at least 70 %
condition(bookcase, cover, "the boards reach from side to side", _, [Top, _, _],
          soft(at_least(share(Top), 0.7), 0.1)).
% shelf.model:24  protrusion(top) at most 20 % of elevation(top)
condition(bookcase, topmost, "little rises above the topmost board", _, [Top, _, _],
          soft(at_most(protrusion(Top), 0.2*elevation(Top)), 0.1)).
% shelf.model:25  gap_below(top) or there is a face f where f underside_of top, gap_below(f)
condition(bookcase, spaced, "there is room between the topmost board and the next", Thing,
          [Top, Left, Right],
          any([soft(between(clear_below(Top), 0.04*elevation(Top), 0.6*elevation(Top)), 0.1),
               some(F, Fs,
                    all([underside_of(F, Top),
                         soft(between(clear_below(F), 0.04*elevation(Top), 0.6*elevation(Top)),
                              0.1)]))])) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [Top, Left, Right]),
              possible(all([underside_of(F, Top),
                            between(clear_below(F), 0.04*elevation(Top), 0.6*elevation(Top))])) ),
            Found),
    sort(Found, Fs).
% shelf.model:27  count(shut) at most 1
condition(bookcase, open, "one side is open", Thing, [Top, Left, Right],
          at_most_of(1, Shut, Shut_groups, 'bookcase.shut'(Shut, Top, Left))) :-
    members(bookcase, shut, Thing, [Top, Left, Right], Shut_members),
    findall([Member], member(Member, Shut_members), Shut_groups).
% shelf.model:28  each face f where area(f) at least 20 % of length(this) * width(this): f is level or f is upright
condition(bookcase, straight, "its large faces are level or upright", Thing, [Top, Left, Right],
          each(F, Fs,
               implies(soft(at_least(area(F), 0.2*thing_length(Thing)*thing_width(Thing)), 0.1),
                       any([level(F), upright(F)])))) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [Top, Left, Right]),
              possible(at_least(area(F), 0.2*thing_length(Thing)*thing_width(Thing))) ),
            Found),
    sort(Found, Fs).
% bookcase.model:4  count(board) at least 3
condition(bookcase, rows, "three boards at least lie below the topmost", Thing,
          [Top, Left, Right], at_least_of(3, Board, Board_groups, 'bookcase.board'(Board, Top))) :-
    members(bookcase, board, Thing, [Top, Left, Right], Board_members),
    separate(Board_members, Board_groups).
% bookcase.model:5  height(this) at least 110 % of length(top)
condition(bookcase, tall, "it is higher than broad", Thing, [Top, _, _],
          soft(at_least(thing_height(Thing), 1.1*length(Top)), 0.1)).

written(bookcase, board, 'shelf.model:12',
        "at least 2 separate faces board where board is level, board is upward, elevation(board) at most 80 % of elevation(top), overlap(board, top) at least 80 %").
written(bookcase, level, 'shelf.model:18', "top is measured, top is level, top is upward").
written(bookcase, sides, 'shelf.model:19',
        "left opposite right, (each x of left, right: x is upright, height(x) at least 80 % of height(this), width(x) at least 50 % of width(top)), apart(left, right)").
written(bookcase, cover, 'shelf.model:23', "share(top) at least 70 %").
written(bookcase, topmost, 'shelf.model:24', "protrusion(top) at most 20 % of elevation(top)").
written(bookcase, spaced, 'shelf.model:25',
        "gap_below(top) or there is a face f where f underside_of top, gap_below(f)").
written(bookcase, open, 'shelf.model:27', "count(shut) at most 1").
written(bookcase, straight, 'shelf.model:28',
        "each face f where area(f) at least 20 % of length(this) * width(this): f is level or f is upright").
written(bookcase, rows, 'bookcase.model:4', "count(board) at least 3").
written(bookcase, tall, 'bookcase.model:5', "height(this) at least 110 % of length(top)").

% shelf.model:12
group(bookcase, Thing, [Top, Left, Right], board, Members) :-
    members(bookcase, board, Thing, [Top, Left, Right], Board_members),
    findall(Board, ( member(Board, Board_members), holds('bookcase.board'(Board, Top)) ),
            Members).
% shelf.model:15
group(bookcase, Thing, [Top, Left, Right], shut, Members) :-
    members(bookcase, shut, Thing, [Top, Left, Right], Shut_members),
    findall(Shut, ( member(Shut, Shut_members), holds('bookcase.shut'(Shut, Top, Left)) ),
            Members).

% shelf.model:31
size(bookcase, _, [Top, _, _], width, length(Top)).
% shelf.model:32
size(bookcase, _, [Top, _, _], depth, width(Top)).
% shelf.model:33
size(bookcase, Thing, [_, _, _], height, thing_height(Thing)).
