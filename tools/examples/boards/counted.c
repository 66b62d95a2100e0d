/* Calls an example, whose main is named `example`, for tools/cost to count. */
void cost_region(unsigned region);
void cost_failed(int status);
void cost_end(void);
int example(void);

int main(void)
{
    cost_region(0);
    if (example()) cost_failed(-1);
    cost_end();
    return 0;
}
